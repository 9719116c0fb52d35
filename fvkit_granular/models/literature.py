"""Works that the models of this package are made after."""

from fvkit.output.citation import Work

#: The two-phase model, its reduced model and its Roe solver.
PELANTI_2008 = Work("article", "pelanti2008", ("M. Pelanti", "F. Bouchut", "A. Mangeney"),
                    "A Roe-type scheme for two-phase shallow granular flows over variable topography",
                    {"journal": "ESAIM: Mathematical Modelling and Numerical Analysis", "volume": "42", "pages": "851--885",
                     "year": "2008", "doi": "10.1051/m2an:2008029"}, "M2AN 42 (2008) 851-885")
