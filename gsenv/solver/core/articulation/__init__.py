"""Islands in joint coordinates: a joint of a tree costs no row.

The bodies of an island are links of trees, whose rates are the unknowns; joints of trees hold by construction.
Contacts, limits and motors stay rows, expressed in these rates.  Featherstone, Rigid Body Dynamics Algorithms, 2008.
"""
