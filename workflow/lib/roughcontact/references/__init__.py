"""What the program is held against: closed forms, and surfaces made by formula."""
