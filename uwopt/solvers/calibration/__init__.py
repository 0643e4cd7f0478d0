"""What test shots say of a model: light times reflectance, water and backscatter, fitted with their intervals."""
