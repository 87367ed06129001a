"""What nets did, as it is kept, thinned out to be drawn, and written as columns."""
