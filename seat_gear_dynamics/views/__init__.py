"""What people see: terminal, figures, report. Data in, picture out."""
