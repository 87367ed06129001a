"""The commands about recordings of waveforms: against the model, and against data sheets."""
