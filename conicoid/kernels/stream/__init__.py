"""The stream route: thousands of rays in no order, sorted so that neighbours are coherent."""
