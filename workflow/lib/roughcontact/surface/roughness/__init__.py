"""What describes a rough surface: height and spectral parameters, power spectra, texture."""
