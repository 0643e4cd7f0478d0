"""Error against run time, on the machine it runs on: `uwopt bench`.

suite       what one measurement is: rows, budgets, the shape of a suite
spectral quadrature physics      the model: error of each integral against time
peers fronts scaling             the search: gap over time, time over size
contest     what peers start from, and who checks their claims
machine     where it was measured: processor, load, versions
run         suites one by one, kept as they come
page        the HTML report
"""
