"""Programs for another part or controller: the command, its report on paper and as data."""
