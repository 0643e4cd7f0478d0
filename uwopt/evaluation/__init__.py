"""One design in one mission: its settings, figures, margins, totals and bill."""
