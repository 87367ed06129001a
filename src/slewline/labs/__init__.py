"""What laboratories reach a module by: a motor behind it, as a record of EPICS."""
