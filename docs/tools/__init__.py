"""Programs that make the site out of the documentation: `make docs`."""
