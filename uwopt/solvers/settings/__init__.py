"""The best settings of given hardware: closed forms, boxes of settings, rounding to what can be set."""
