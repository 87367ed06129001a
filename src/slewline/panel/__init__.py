"""Front ends that show a bench while it runs, over its control port."""
