"""Many runs on one page: tables, curves and pictures made from run folders."""
