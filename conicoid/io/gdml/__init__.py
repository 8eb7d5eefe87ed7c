"""Reader of GDML, the geometry files of Geant4 and ROOT."""
