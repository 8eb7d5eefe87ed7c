"""Compiled kernels on disk: where they are, whether they are trusted, their files, and the removal of old ones.

The folder's name has a hash over all sources of the package, so an edited package finds no old code. A file holds one
kernel for one signature and processor, after a checksum. It is a pickle, that is, a program: it is read only where
nobody else can have written it. What is damaged is dropped. Where nothing can be written kernels are compiled in
memory, and the log says so in one line.
"""
