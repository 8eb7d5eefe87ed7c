"""The systems of the four source documents, each with a number by hand or in closed form."""
