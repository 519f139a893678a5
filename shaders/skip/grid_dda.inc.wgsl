// Samples in the active blocks of a walk from block to block. Twin of skip::grid_dda.
#import shared/walk
#import step/one
