"""Lower bounds of the distance to the nearest wall, of 64 points together: what transport codes call safety."""
