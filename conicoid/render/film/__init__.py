"""From samples of light to a picture: filters, sums of samples and their errors, layers, tone curves, colour maps."""
