use limber_base_version, only: version
print '(2a)', 'limber ', version
end
