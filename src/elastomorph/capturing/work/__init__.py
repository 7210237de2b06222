"""A capture from what is asked for to its files, stage by stage."""
