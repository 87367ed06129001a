"""The return types of `bench.add`, `bench.part` and `bench.host`, which depend on the name passed.

See the stub file next to this one.
"""
