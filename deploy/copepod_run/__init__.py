"""What a run needs: the build, its three processes, their watch and clean-up, its folder and its figures."""
