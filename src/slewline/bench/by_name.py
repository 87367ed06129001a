"""The return types of `bench.add`, `bench.part` and `bench.host`, which depend on the arguments.

The stub file `by_name.pyi` declares them.
"""
