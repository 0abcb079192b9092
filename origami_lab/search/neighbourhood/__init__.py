"""Large-neighbourhood search: cut parts of a design away, grow it again, keep what is better.

For target shapes the growing is guided by the part of the target that the sheet does not come near yet, and bounded by
an aspiration threshold; for any other objective it is random, and late acceptance decides. Either way many short runs,
each at one driving angle, compete for the budget.
"""
