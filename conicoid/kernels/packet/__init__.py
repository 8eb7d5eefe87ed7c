"""The route of packets: 64 coherent rays side by side."""
