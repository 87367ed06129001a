# Completion of slewline in fish.
_SLEWLINE_COMPLETE=fish_source slewline | source
