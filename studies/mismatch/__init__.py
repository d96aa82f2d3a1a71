"""How often the mismatch tool is right: its answers to concealed effects, and to recordings of real robots.

A study: it runs from a checkout of the source and is not part of the installed package.
"""
