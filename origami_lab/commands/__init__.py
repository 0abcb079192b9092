"""The subcommands, one module each with ``main(arguments) -> exit code``; imported when called, to start fast."""

COMMANDS = ("dashboard", "doctor", "export", "report", "sweep", "verify")
