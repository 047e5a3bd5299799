"""Read reaction times from tables: by named columns, or by the marks of well-known programs."""
