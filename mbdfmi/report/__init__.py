"""What is told about runs: speed, beside that of other libraries."""
