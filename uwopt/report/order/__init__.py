"""What a buyer works with: workbooks of the bill and of a tender, a letter, answers read back."""
