"""The types of what `bench.add`, `bench.part` and `bench.host` return, name by name: see the stub beside this file."""
