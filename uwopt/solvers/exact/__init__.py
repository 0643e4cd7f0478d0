"""The certified search over hardware: bounds, best-first order, account, certificate, audit."""
