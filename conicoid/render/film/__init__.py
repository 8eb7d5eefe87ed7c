"""What light becomes on its way to a picture: filters, sums of samples and their errors, tone curves."""
