"""The steps of the migrations, one file for each."""
