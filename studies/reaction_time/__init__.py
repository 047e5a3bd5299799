"""The reaction-time study: protocol, fit, report."""
