"""The return types of `bench.add`, `bench.part` and `bench.host` by name: see the stub file next to this one."""
