"""The packet route: 64 coherent rays traced side by side, in the lanes of vectors."""
