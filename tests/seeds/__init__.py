"""The systems of the four source documents, each with a number worked out by hand or in closed form."""
