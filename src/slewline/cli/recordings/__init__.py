"""The commands for recorded waveforms: comparison with the model or with data sheets, and decoding."""
