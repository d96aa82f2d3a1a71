"""A two-truck robot in MuJoCo: wheels, bumps, tyres and floors that act by contact, and their labels."""
