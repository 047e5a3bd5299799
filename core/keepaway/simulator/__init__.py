"""The simulator of Keepaway: the server's physics and the players' perception and skills."""
