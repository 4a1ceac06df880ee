def write_results(window):
    raise SystemExit("later")
