"""The commands that compare recorded waveforms with the model and with data sheets."""
