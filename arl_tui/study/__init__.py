"""What a participant meets in a study between its sessions: consent, texts, questions, breaks, thanks."""
