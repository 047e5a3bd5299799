"""Read reaction times from tables: of any program by named columns, of well-known programs by their own marks."""
