"""What makes the site out of the documentation: `make docs`."""
