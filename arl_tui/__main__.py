"""`python -m arl_tui` is the command `arl`."""

from arl_tui.cli import main

# Processes that fits start import this module, too.
if __name__ == "__main__":
    main(prog_name="arl")
