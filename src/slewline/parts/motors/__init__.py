"""Stepper motors by their equations: data of motors, drivers and loads, the law they follow, and its integration."""
