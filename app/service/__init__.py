"""What computes for visitors: worker processes, what runs in them, and what is kept for all."""
