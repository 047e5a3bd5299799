"""What `arl doctor` looks at: this machine, this terminal, the keyboard."""
