"""One reference for rays at bodies: exact, and without any code or rule of the package.

It starts from the parameters of a user. A solid is a Boolean formula over polynomials (`solids`), with coefficients
that are exact where sines and axes let them be, and else rounded to 3,000 bits (`numbers`). A ray makes integer
quadratics of the polynomials (`quadratics`). Resultants decide which roots are equal, intervals which comes first.
`trace` finds the crossings, `judge`, `intervals` and `routes` compare the package's answers with them. `random_items`
draws bodies, `aimed_rays` and `whole_rays` draw rays, and `suite` puts them together.
"""
