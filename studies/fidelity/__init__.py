"""How closely simulators and learners follow their references."""
