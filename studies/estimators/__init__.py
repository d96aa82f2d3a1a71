"""The accuracy of the estimators: tracking, IPEC, UMBmark, relative poses and the fleet's joint model."""
