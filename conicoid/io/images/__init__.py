"""Images and movies, and the codecs of their files."""
