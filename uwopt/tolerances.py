"""How nearly numbers must agree, and which tolerance must be larger than which for the certificate to hold.

SLACK < ROUND - 1 <= TIE << SATISFIED_REL = AGREES_REL = BEATS_REL << BINDING_REL < PROVEN_GAP_REL

- A closed form opens its windows by SLACK, a rounding error: a window of one point is not lost.
- The search lets a limit be exceeded by ROUND - 1, and takes two objectives within TIE for equal. Bounds that
  are summed in another order than what they bound use COARSE_ROUND, a little more, so that none is too high.
- The evaluation calls a requirement met within SATISFIED_REL of its limit. It must be larger than ROUND - 1:
  what the search allows, the evaluation must not refuse. The search's claim and the evaluation agree within
  AGREES_REL, and an audit calls a discarded design better from BEATS_REL on: both larger than TIE, or ties would
  be defects.
- Medians of systems over the scenarios of a choice are a tie within TIED_MEDIANS_REL, about what luck makes of them
  in 256. What was chosen of counted shares is one time in twenty better than the truth by LUCK standard errors.
- A margin below BINDING_REL is called binding. A proof whose gap is above PROVEN_GAP_REL is not called optimal.
"""

SLACK = 1e-12
ROUND = 1.0 + 1e-9
COARSE_ROUND = 1.0 + 2e-9
TIE = 1e-9
SATISFIED_REL = 1e-6
AGREES_REL = 1e-6
BEATS_REL = 1e-6
BINDING_REL = 1e-4
PROVEN_GAP_REL = 2e-4
TIED_MEDIANS_REL = 0.02
LUCK = 1.64
