"""The route of streams: thousands of rays in no order, sorted."""
