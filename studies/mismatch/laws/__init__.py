"""Laws that are learned in the place of named effects: how much of what these explain they recover."""
