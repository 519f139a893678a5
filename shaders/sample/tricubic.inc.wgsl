// The cubic B-spline by eight fetches of the adapter's filter. Twin of sample::Sampler::Tricubic.
#import fetch/filter
#import shared/bspline
