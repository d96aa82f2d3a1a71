"""Bus logs: frames, candump and foreign formats, filters, decoding, assembly of samples."""
