"""What is read or written: bus logs, recording folders, other tools' formats. No physics."""
