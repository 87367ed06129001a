"""The language of the chips: decoders, assembler, disassembler, linter, reference.  It reads sheets alone."""
