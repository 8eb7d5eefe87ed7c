"""Tables of edited scenes, made from those of the scene before."""
